"""What a person does on the bench, recorded, and whether it is what was asked for."""
