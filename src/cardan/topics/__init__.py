"""Topics: one package each, from the section of the file to its terminal lines and chapter."""
