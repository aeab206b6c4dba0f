"""The workbench: a face in the browser, on this machine alone. It reads, asks and shows.

desk      the opened files, their drafts, what changes on disk
answer    a document in, results out: keys, numbers, arrays
worker    the process that answers
lanes     one question under way in each, the latest one next
guard     who may ask at all
server    the socket, the pages, and how it starts and ends
"""
