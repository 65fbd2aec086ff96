"""The viewer in a browser: a canvas whose picture is a page, and the server that guards it."""
