"""Real devices, one module for each way of speaking to them."""
