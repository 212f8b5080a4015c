// What moves in the picture, received from the session over its own WebSocket.

const AGAIN = 500; // Before a socket that closed is opened again [ms].
const SILENT = 3000; // Without data from the session, the picture is frozen [ms].

export class Motion {
  // `still(why)` is called with why the picture is frozen, or nothing if it is not.
  constructor(still) {
    this.still = still;
    this.viewer = null;
    this.last = 0; // When data last arrived [ms].
    setInterval(() => this.#check(), SILENT / 3);
  }

  // Shows what moves in Meshcat's viewer from now on.
  show(viewer, { THREE }) {
    this.viewer = viewer;
    this.lines = THREE.Float32BufferAttribute;
    this.#open();
  }

  // Shows nothing any more.
  end() {
    this.viewer = null;
    this.socket?.close();
  }

  #open() {
    this.socket?.close();
    const secure = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${secure}://${location.host}/view/`);
    this.socket = socket;
    this.points = {}; // Of lines, by path; the session sends all again.
    this.last = performance.now();
    socket.onmessage = ({ data }) => {
      if (socket !== this.socket || !this.viewer) return;
      this.last = performance.now();
      this.#move(JSON.parse(data));
      this.still("");
    };
    socket.onclose = () => {
      if (socket !== this.socket || !this.viewer) return;
      this.still("The picture is frozen: no connection to the session.");
      setTimeout(() => socket === this.socket && this.viewer && this.#open(), AGAIN);
    };
  }

  #check() {
    if (!this.viewer || performance.now() - this.last < SILENT) return;
    this.still("The picture is frozen: no data from the session.");
    this.#open();
  }

  #move({ poses, lines }) {
    for (const [path, matrix] of Object.entries(poses)) {
      this.viewer.handle_command({ type: "set_transform", path, matrix });
    }
    for (const [path, news] of Object.entries(lines)) this.#draw(path, news);
  }

  // Draws a line that keeps so many of its last points, and adds some.
  #draw(path, { keep, add }) {
    const before = this.points[path] ?? [];
    const points = [...before.slice(before.length - keep), ...add];
    this.points[path] = points;
    const names = path.split("/").filter(Boolean);
    const { geometry } = this.viewer.scene_tree.find([...names, "<object>"]).object;
    geometry.dispose(); // Frees its memory on the graphics card.
    geometry.setAttribute("position", new this.lines(points.flat(), 3));
    geometry.computeBoundingSphere();
    this.viewer.set_dirty();
  }
}
