"""Sensor models: GNSS, wheel odometry, IMU, LiDAR and camera, each with mount, rate, noise, latency and drop-outs."""

from vehicle.sensors.camera import Camera
from vehicle.sensors.common import Mount, Timing
from vehicle.sensors.gnss import Gnss
from vehicle.sensors.imu import InertialUnit
from vehicle.sensors.lidar import Lidar
from vehicle.sensors.odometry import WheelOdometry
from vehicle.sensors.suite import SensorSuite, default_sensors

__all__ = [
    "Camera",
    "Gnss",
    "InertialUnit",
    "Lidar",
    "Mount",
    "SensorSuite",
    "Timing",
    "WheelOdometry",
    "default_sensors",
]
