"""The CPU engine: SIMD-lane kernels on a thread pool."""
