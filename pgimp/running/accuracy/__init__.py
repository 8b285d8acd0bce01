"""What a run shows of its own accuracy: indicators, each with a bound that has a reason."""
