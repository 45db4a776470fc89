"""Our engine beside an interpreter of its own, written from appendix D of the W3C's SCXML alone."""
