"""`tfsat-host calibrate`: guided measurements before a drop."""
