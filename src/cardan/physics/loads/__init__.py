"""Loads of joints, centre bearings and flanges over one revolution."""
