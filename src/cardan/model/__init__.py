"""What a driveline is: parts, layouts, the vehicle around them, the application.

Every number of a part may be an array instead: the variants of a study. Its last axis, of
length 1, is that of the states; V variants of a number are (V, 1), and with them what
follows is (V, states).
"""
