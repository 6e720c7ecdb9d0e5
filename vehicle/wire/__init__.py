"""The wire between harness and car: ROS 2 messages on DDS, as ROS 2 itself puts them there."""
