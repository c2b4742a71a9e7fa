"""Zero points and bend of a joint's two absolute angle sensors."""
