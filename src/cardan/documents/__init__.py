"""Documents of a whole application: approval report, JSON, terminal, workbook, drawings."""
