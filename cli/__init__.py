"""drone-cli: checks, flies and shows missions."""
