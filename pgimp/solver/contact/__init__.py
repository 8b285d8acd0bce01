"""Contact in the step: velocity fields, clearances, free rigid bodies."""
