"""SIMD lanes as ordinary values."""
