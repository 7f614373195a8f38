"""Frames in, pages out: metrics, figures, tables and one self-contained page."""
