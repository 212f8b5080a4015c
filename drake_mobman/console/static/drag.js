// A point of the arm, dragged in the 3D view with Ctrl and the mouse. Meshcat supports it,
// from Drake 1.57 on, and reports it to its server; here it is a command, and is sent as
// all commands are.

const PARTS = "drake"; // What may be dragged is below it, by the name of its body.

export class Drag {
  // `changed()` is called where the drag does.
  constructor(changed) {
    this.changed = changed;
    this.waits = false; // Until the drag is released: it has no effect any more.
    this.pull = undefined; // The body, the point in it, and where to, from the base.
  }

  get held() {
    return this.pull !== undefined;
  }

  neutral() {
    this.waits ||= this.held;
    this.pull = undefined;
  }

  // Receives what Meshcat sends in its window, in place of a server: it has none.
  listen({ viewer, MeshCat }) {
    this.neutral();
    this.waits = false;
    if (!viewer) return;
    const send = (bytes) => {
      const said = MeshCat.msgpack.decode(bytes);
      if (said.type === "mouse_drag") this.#hear(said, viewer, MeshCat.THREE);
    };
    viewer.connection = { readyState: WebSocket.OPEN, send };
  }

  // Points are in the picture's frame, where the base stays in the middle.
  #hear({ name, drag_anchor, drag_target }, viewer, { Vector3 }) {
    if (name && this.waits) return;
    if (!name) {
      this.neutral();
      this.waits = false;
    } else {
      const body = name.split("/")[2];
      this.pull = {
        body,
        point: this.pull?.point ?? within(viewer, body, new Vector3(...drag_anchor)),
        to: drag_target.map(rounded),
      };
    }
    this.changed();
  }
}

// A point in the frame of a body, in which it stays while the body moves.
function within({ scene, scene_tree }, body, place) {
  const part = scene_tree.find([PARTS, body]).object;
  return part.worldToLocal(scene.localToWorld(place)).toArray().map(rounded);
}

function rounded(x) {
  return Math.round(x * 1e5) / 1e5; // [m].
}
