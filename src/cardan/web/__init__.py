"""The workbench: an interface in the browser, on this machine alone. It computes nothing itself.

workspace    the opened files, their drafts, what changes on disk
handlers     a document in, results out: keys, numbers, arrays
worker       the process that computes
worker_pool  one request under way in each process, the latest one next
security     which requests are accepted at all
server       the socket, the pages, and how it starts and ends
"""
