"""Contact as the step drives it: velocity fields, clearances, rigid bodies that move freely."""
