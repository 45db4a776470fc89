"""World files with faults, shared by the tests of the loader and of the schema."""

from __future__ import annotations

W = "world: w\n"
BOX = "{at: [9, 9], size: [1, 1, 1]"

SHAPE_FAULTS = [
    ("description: x\n", ["1:1 missing-key"]),
    (W + "colour: red\n", ["2:1 unknown-key"]),
    ("world: [w]\n", ["1:8 wrong-type"]),
    ("world:\n", ["1:7 wrong-type"]),
    # Maps.
    (W + "boxes: [a, b]\n", ["2:8 wrong-type"]),
    (W + "boxes: {a: big}\n", ["2:12 wrong-type"]),
    (W + "boxes: {a: {at: [1, 2]}}\n", ["2:12 missing-key"]),
    (W + "boxes: {a: {size: [1, 2, 1]}}\n", ["2:12 missing-key"]),
    (W + "boxes:\n  a: {at: [9, 9], size: [1, 1, 1], colr: red}\n", ["3:36 unknown-key"]),
    (W + "boxes: {Big Shed: {at: [9, 9], size: [1, 1, 1]}}\n", ["2:9 bad-name"]),
    (W + "beacons: {b: {}}\n", ["2:14 missing-key"]),
    (W + "ground: green\n", ["2:9 wrong-type"]),
    (W + "ground: {size: 0 m}\n", ["2:16 bad-size"]),
    (W + "ground: {color: gras}\n", ["2:17 unknown-color"]),
    (W + "ground: {color: [1, 2]}\n", ["2:17 wrong-type"]),
    (W + "ground: {color: [1, 2, 256]}\n", ["2:17 wrong-type"]),
    (W + "ground: {color: [1, 2, 3, x]}\n", ["2:17 wrong-type"]),
    (W + "light: {hight: 3}\n", ["2:9 unknown-key"]),
    (W + "light: {ambient: 2}\n", ["2:18 out-of-range"]),
    # Quantities.
    (W + "battery: full\n", ["2:10 wrong-type"]),
    (W + "fence: {}\n", ["2:8 missing-key"]),
    (W + "fence: {through: [[0, 0], [9, 0]]}\n", ["2:18 wrong-type"]),
    (W + "fence: {through: [[0, 0], [9, 0], [9, 9, 1]]}\n", ["2:35 wrong-type"]),
    (W + "fence: {through: [[0, 0], [9, 0], [9, 9]], ceiling: 3 s}\n", ["2:53 wrong-dimension"]),
    (W + "battery: 20 m\n", ["2:10 wrong-dimension"]),
    (W + "battery: -0.1\n", ["2:10 out-of-range"]),
    (W + "battery: [1]\n", ["2:10 wrong-type"]),
    (W + "start: {at: [0, 0], heading: 3 m}\n", ["2:30 wrong-dimension"]),
    (W + "start: {at: [0, 0], heading: 90 dge}\n", ["2:30 unknown-unit"]),
    (W + "origin: {lat: 1, lon: 2, alt: 3 kg}\n", ["2:31 wrong-dimension"]),
    (W + "origin: {lat: 91, lon: 2}\n", ["2:15 out-of-range"]),
    (W + "origin: {lat: 1}\n", ["2:9 missing-key"]),
    (W + "origin: {lat: north, lon: 1}\n", ["2:15 wrong-type"]),
    # Sizes and places.
    (W + "boxes: {a: {at: [9, 9], size: [1, -1, 1]}}\n", ["2:35 bad-size"]),
    (W + "boxes: {a: {at: [9, 9], size: [1, 0, 1]}}\n", ["2:35 bad-size"]),
    (W + "boxes: {a: {at: [9, 9], size: [1, 1]}}\n", ["2:31 wrong-type"]),
    (W + "boxes: {a: {at: [9, .nan], size: [1, 1, 1]}}\n", ["2:21 wrong-type"]),
    (W + "places: {p: [1, 2]}\n", ["2:13 wrong-type"]),
    (W + "places: {p: 3}\n", ["2:13 wrong-type"]),
    (W + "places: {p: [1, 2, 3 s]}\n", ["2:20 wrong-dimension"]),
    (W + "start: []\n", ["2:8 wrong-type"]),
    (W + "start: {at: [0]}\n", ["2:13 wrong-type"]),
    (W + "start: {heading: 0}\n", ["2:8 missing-key"]),
    # Kinds of things.
    (W + "people: {ann: {at: [9, 9], lying: flat}}\n", ["2:35 wrong-type"]),
    (W + "cylinders: {c: {at: [9, 9], radius: 1}}\n", ["2:16 missing-key"]),
    (W + "walls: {w: {through: [[1, 2]]}}\n", ["2:22 wrong-type"]),
    (W + "walls: {w: {through: [[1, 2], [3, 4, 5]]}}\n", ["2:31 wrong-type"]),
    (W + "gates: {g: {at: [9, 9], size: [1]}}\n", ["2:31 wrong-type"]),
    (W + "markers: {m: {at: [9, 9], size: 1, id: 1.5}}\n", ["2:40 wrong-type"]),
    (W + "markers: {m: {at: [9, 9], size: 1, id: -1}}\n", ["2:40 out-of-range"]),
    (
        W + "markers: {m: {at: [9, 9], size: 1, id: 1, dictionary: 4X4_55}}\n",
        ["2:55 unknown-dictionary"],
    ),
    (W + "roads: {r: {through: [[0, 0]]}}\n", ["2:22 wrong-type"]),
    (W + "roads: {r: {through: [[0, 0], [9, 0]], gaps: [4]}}\n", ["2:47 wrong-type"]),
    (
        W + "cars: {c: {moves: {through: [[1, 1], [2, 2]], speed: 0}}}\n",
        ["2:54 bad-size"],
    ),
    (W + "cars: {c: {moves: {through: [[1, 1], [2, 2]]}}}\n", ["2:19 missing-key"]),
    (
        W + "cars: {c: {at: [1, 1], moves: {through: [[5, 5], [6, 6]], speed: 1}}}\n",
        ["2:16 two-places"],
    ),
    (W + "ground: {terrain: {heights: [[0, 0, 0], [0, 1, 0]], size: 9}}\n", ["2:29 wrong-type"]),
    (W + "wind: 5 m/s\n", ["2:7 wrong-type"]),
    (W + "wind: 5\n", ["2:7 wrong-type"]),
    (W + "wind: [5, 270]\n", ["2:7 wrong-type"]),
    (W + "wind: {speed: 5}\n", ["2:7 missing-key"]),
    (W + "wind: {speed: 5, from: west}\n", ["2:24 wrong-type"]),
    (W + "wind: {speed: 5, from: 9, gusts: {every: 9 s}}\n", ["2:34 missing-key"]),
    (W + "wind: {speed: 5, from: 9, turbulence: much}\n", ["2:39 wrong-type"]),
    # Several at once, in the order of the file.
    (
        "world: w\nbatery: 1\nboxes:\n  a: {at: [9], size: [1, 1, -1]}\nplaces: {p: [1, 2, 3 s]}\n",
        ["2:1 unknown-key", "4:11 wrong-type", "4:29 bad-size", "5:20 wrong-dimension"],
    ),
]
"""Files and their faults, as ``line:column code``, that a schema can tell."""

OTHER_FAULTS = [
    (W + "battery: 120 %\n", ["2:10 out-of-range"]),
    (W + "origin: {lat: 1, lon: -181 deg}\n", ["2:23 out-of-range"]),
    (W + "boxes: {a: {at: [9, 9], size: [1, 1, 1e999]}}\n", ["2:38 out-of-range"]),
    (W + "places: {p: [1, 2, 100001 m]}\n", ["2:20 out-of-range"]),
    (W + "wind: 5 m/s@400 deg\n", ["2:7 out-of-range"]),
    (W + "wind: {speed: 5, from: 9, gusts: 4 m/s}\n", ["2:34 bad-gusts"]),
    # Names.
    (W + "beacons: {b: {at: [1, 2, 3]}}\nplaces: {b: [1, 2, 3]}\n", ["3:10 duplicate-name"]),
    (W + "places: {b: [1, 2, 3], b: [4, 5, 6]}\n", ["2:24 duplicate-key"]),
    (W + f"cars: {{a: {{at: [5, 5]}}}}\nboxes: {{a: {BOX}}}}}\n", ["3:9 duplicate-name"]),
    (
        W + f"boxes: {{a: {BOX}}}}}\nroads: {{a: {{through: [[0, 0], [1, 1]]}}}}\n"
        "beacons: {a: {at: [1, 1, 1]}}\n",
        ["3:9 duplicate-name", "4:11 duplicate-name"],
    ),
    # Starts.
    (
        W + "boxes: {a: {at: [1, 0], size: [1, 1, 1]}}\nstart: {at: [1.4, 0]}\n",
        ["3:8 start-in-thing"],
    ),
    (
        W + "boxes: {a: {at: [1, 0], size: [1, 1, 1]}}\nstart: [{at: [5, 5]}, {at: [1.8, 0]}]\n",
        ["3:23 start-in-thing"],
    ),
    (W + "boxes: {a: {at: [0, 0], size: [1, 1, 1]}}\n", ["1:1 start-in-thing"]),
    (W + "cylinders: {a: {at: [0.9, 0], radius: 60 cm, height: 2}}\n", ["1:1 start-in-thing"]),
    (W + "spheres: {a: {at: [0.9, 0], radius: 60 cm}}\n", ["1:1 start-in-thing"]),
    (W + "walls: {a: {through: [[-3, 0.3], [3, 0.3]]}}\n", ["1:1 start-in-thing"]),
    (
        W + "cars: {a: {moves: {through: [[0, 2], [5, 5]], speed: 1}}}\nstart: {at: [0, 2]}\n",
        ["3:8 start-in-thing"],
    ),
    (W + "start: [{at: [0, 0]}, {at: [0.5, 0.5]}]\n", ["2:23 starts-overlap"]),
    (W + "start: {at: [0, 0, -1]}\n", ["2:8 start-in-ground"]),
    # Things whose keys do not go together.
    (W + "markers: {m: {at: [9, 9], size: 1, id: 50}}\n", ["2:40 no-such-marker"]),
    (
        W + "boxes: {m: " + BOX + ", marker: {id: 30, size: 0.2, dictionary: APRILTAG_16h5}}}\n",
        ["2:55 no-such-marker"],
    ),
    (
        W + "boxes: {m: " + BOX + ", marker: {id: 1, size: 0.9}}}\n",
        ["2:50 marker-too-large"],
    ),
    (
        W + "markers: {m: {at: [9, 9], id: 1, size: 1, inside: {id: 2, size: 0.4}}}\n",
        ["2:51 marker-too-large"],
    ),
    (
        W + "markers: {m: {at: [9, 9], id: 1, size: 1, inside: {id: 50, size: 0.1}}}\n",
        ["2:56 no-such-marker"],
    ),
    (W + "markers: {m: {at: [9, 9], size: 1, id: 1, lean: 10 deg}}\n", ["2:49 lies-flat"]),
    (
        W + "boards: {b: {at: [9, 9], columns: 9, rows: 12, square: 0.1, marker: 0.08}}\n",
        ["2:13 no-such-marker"],
    ),
    (
        W + "boards: {b: {at: [9, 9], columns: 5, rows: 7, square: 0.1, marker: 0.1}}\n",
        ["2:68 bad-size"],
    ),
    (W + "walls: {w: {through: [[1, 2], [1, 2]]}}\n", ["2:22 bad-path"]),
    (
        W + "cars: {c: {moves: {through: [[1, 9], [1, 9]], speed: 1}}}\n",
        ["2:29 bad-path"],
    ),
    (
        W + "cars: {c: {moves: {through: [[5, 5], [9, 9], [5, 5]], speed: 1, loop: true}}}\n",
        ["2:29 bad-path"],
    ),
    (
        W + "ground: {terrain: {heights: [[0, 0, 0], [0, 1], [0, 0, 0]], size: 9}}\n",
        ["2:41 wrong-type"],
    ),
    (
        W + "ground: {terrain: {heights: [[0, 0, 0], [0, 1, 0], [0, 2, 0]], size: 9}}\n",
        ["2:29 bad-terrain"],
    ),
    (
        W + "ground: {terrain: {heights: [[0, 0, 0], [0, -1, 0], [0, 0, 0]], size: 9}}\n",
        ["2:29 bad-terrain"],
    ),
    # Roads.
    (
        W + "roads: {r: {through: [[0, 0], [9, 0], [9, 9], [5, -5]]}}\n",
        ["2:22 road-crosses-itself"],
    ),
    (W + "roads: {r: {through: [[0, 0], [9, 0]], gaps: [[8, 10]]}}\n", ["2:46 bad-gap"]),
    (W + "roads: {r: {through: [[0, 0], [9, 0]], gaps: [[5, 4]]}}\n", ["2:46 bad-gap"]),
    (W + "roads: {r: {through: [[0, 0], [0, 0]]}}\n", ["2:22 bad-path"]),
    (
        W + "roads: {r: {through: [[0, 0], [9, 0]], edges: white, edge_width: 2}}\n",
        ["2:66 bad-size"],
    ),
    # Files.
    (W + "ground: {texture: none.png}\n", ["2:19 no-such-file"]),
    (W + "meshes: {m: {at: [9, 9], file: none.obj}}\n", ["2:32 no-such-file"]),
    ("", ["1:1 empty-file"]),
    ("a: [\n", ["2:1 bad-yaml"]),
]
"""Files and their faults that a schema cannot tell."""
