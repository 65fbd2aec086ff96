"""Measuring glimt: rays against Embree in one run, frames, and two results against each other."""
