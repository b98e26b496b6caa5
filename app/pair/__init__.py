"""Try a pair: predictions of own pictures, the sensor and its relief, and teaching."""
