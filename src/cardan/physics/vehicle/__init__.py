"""What the vehicle demands of the line: torque, speed, axle motion, layout by state."""
