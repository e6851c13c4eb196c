"""Messages of ROS 2, as the bridge hears them and as bags hold them, in our own terms and back."""
