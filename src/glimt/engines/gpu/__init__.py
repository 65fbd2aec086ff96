"""The engine for graphics processors: WGSL kernels through wgpu, on Vulkan, Metal or Direct3D 12."""
