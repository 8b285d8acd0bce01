"""What ``pgimp check`` says of a case that takes a simulation to know: steps, time and memory."""
