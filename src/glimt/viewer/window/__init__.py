"""The viewer in a desktop window, with OpenGL and without a GPU."""
