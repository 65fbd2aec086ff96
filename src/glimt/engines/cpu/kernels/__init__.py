"""The five stages of a frame and their helpers, as SIMD-lane kernels. Start at `frame`, then `radiance`."""
