"""Ask questions of an application: assess it, correct it, verify the program itself."""
