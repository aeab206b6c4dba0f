"""Rendering primitives: document blocks, charts, HTML, PDF, workbook, terminal, languages."""
