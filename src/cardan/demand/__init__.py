"""What the vehicle asks of the driveline, state by state: torque, speed, axle loads, geometry."""
