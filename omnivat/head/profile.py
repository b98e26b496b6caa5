"""A new sensor: profiles of its pictures, and what they bring back."""
