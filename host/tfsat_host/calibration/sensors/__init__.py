"""What is known of one gyro and of one joint's angle sensors."""
