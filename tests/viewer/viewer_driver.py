"""A scene that renders in no time, and a viewer of it with a clock of its own."""

import glimt


class Driver:
    """Sends events to a viewer and lets time pass, 10 ms a frame."""

    def __init__(self, viewer):
        self.viewer, self.now, self.picture, self.pictures = viewer, 100.0, None, 0

    def send(self, event_type, **event):
        self.viewer.handle({"event_type": event_type, **event}, self.now)

    def press(self, key, *modifiers):
        self.send("key_down", key=key, modifiers=modifiers)
        self.send("key_up", key=key, modifiers=modifiers)
        self.run(0.01)

    def run(self, seconds):
        end = self.now + seconds - 1e-9
        while self.now < end:
            self.now += 0.01
            picture = self.viewer.frame(self.now)
            if picture is not None:
                self.picture, self.pictures = picture.copy(), self.pictures + 1

    def rest(self):
        for _ in range(2000):
            self.run(0.01)
            if self.viewer.at_rest:
                return
        raise AssertionError("the viewer does not come to rest")

    def click(self, x, y, event_type=None):
        for name in ("pointer_down", "pointer_up"):
            self.send(name, x=x, y=y, button=1, buttons=(1,) if name == "pointer_down" else (), modifiers=())
        if event_type:
            self.send(event_type, x=x, y=y, button=1, buttons=(), modifiers=())
        self.run(0.01)

    def drag(self, dx, dy, button=1):
        self.send("pointer_down", x=40.0, y=30.0, button=button, buttons=(button,), modifiers=())
        for k in range(1, 11):
            self.send("pointer_move", x=40 + dx * k / 10, y=30 + dy * k / 10, button=0, buttons=(button,), modifiers=())
        self.send("pointer_up", x=40 + dx, y=30 + dy, button=button, buttons=(), modifiers=())
        self.run(1.0)


def make_scene(**settings):
    """Return a red sphere left and a green quad right of the middle, lit by one light that stands still."""
    quad = glimt.Mesh([(0.2, -1, 0), (2, -1, 0), (2, 1, 0), (0.2, 1, 0)], [(0, 1, 2), (0, 2, 3)],
                      materials=[glimt.Material(diffuse=(0.1, 0.8, 0.1), name="green")], name="quad")
    sphere = glimt.Sphere((-1.2, 0.0, 0.0), 0.8, glimt.Material(diffuse=(0.9, 0.1, 0.1), name="red"), name="ball")
    scene = glimt.Scene(camera=glimt.Camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0)), name="two",
                        settings=glimt.RenderSettings(80, 60, ambient=0.1, background=0.2, **settings))
    return scene.add(quad, sphere, glimt.PointLight(position=(0.0, 2.0, 4.0), radius=4.0))
