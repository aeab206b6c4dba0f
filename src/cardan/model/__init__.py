"""What a driveline is: parts, layouts, the vehicle around them, the application."""
