"""What of the final attitude's error each part of the instruments is to blame for, before a drop."""
