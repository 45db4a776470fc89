"""SCXML: documents of other programs are loaded, missions are exported and imported again."""

from fsm.scxml.document import Element, parse_document, read_document, sources
from fsm.scxml.importer import import_mission, is_mission
from fsm.scxml.loader import load_document
from fsm.scxml.stepping import advance
from fsm.scxml.writer import write_scxml

__all__ = [
    "Element",
    "advance",
    "import_mission",
    "is_mission",
    "load_document",
    "parse_document",
    "read_document",
    "sources",
    "write_scxml",
]
