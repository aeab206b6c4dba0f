"""An application of one shaft whose pinion is shimmed: the smallest with something to correct."""

ONE_SHAFT = """\
title: Under the truck
speed_rpm: 3600
torque_Nm: 300
driveline:
  slopes: {side_deg: [4.0, 2.0, 7.5]}
  joints: "1310"
  shafts: [{length_mm: 1200, tube: 76.2x2.1}]
limits: protractor
adjust: {shim_deg: [-4, 4]}
"""
