// A point of the arm, dragged in the 3D view by Ctrl and the mouse. Meshcat knows how, from
// Drake 1.57 on, and tells its server; but to pull is to command, and goes the way of all
// commands.

const PARTS = "drake"; // What may be dragged is below it, by the name of its body.

export class Drag {
  // `changed()` is called where the drag does.
  constructor(changed) {
    this.changed = changed;
    this.waits = false; // Until what is dragged is let go: it counts no more.
    this.pull = undefined; // The body, the point in it, and whereto, from the base.
  }

  get held() {
    return this.pull !== undefined;
  }

  neutral() {
    this.waits ||= this.held;
    this.pull = undefined;
  }

  // Hears what Meshcat says in its window, in the place of a server: it has none.
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

  // Places come in the picture's frame, where the base stays in the middle.
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

// Where a place is in the frame of a body: it stays there while that moves.
function within({ scene, scene_tree }, body, place) {
  const part = scene_tree.find([PARTS, body]).object;
  return part.worldToLocal(scene.localToWorld(place)).toArray().map(rounded);
}

function rounded(x) {
  return Math.round(x * 1e5) / 1e5; // [m].
}
