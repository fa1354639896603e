// The socket to softsim-web: what it sends, decoded (clients/web/hub.h and body.h have the layout),
// and what it takes. A lost connection is tried again; what was told over the old one is then forgotten
// (main.js), since the server tells all there is. One that says nothing, though a server is there that speaks four times a second, is lost too: a peer that vanished
// closes nothing.

const HEAD = 4, RETRY_MS = 1000, QUIET_TICKS = 4; // of RETRY_MS
const DISPLACED = 4000; // another page has the place of this one: serve.c

function topology(buffer) {
  const head = new DataView(buffer);
  const nodes = head.getUint32(4, true), triangles = head.getUint32(8, true);
  const rest = 16, index = rest + 12 * nodes, flag = index + 12 * triangles;
  return {
    nodes, triangles, scale: head.getFloat32(12, true),
    rest: new Float32Array(buffer, rest, 3 * nodes),
    index: new Uint32Array(buffer, index, 3 * triangles),
    flag: new Uint8Array(buffer, flag, nodes),
  };
}

function delta(buffer) {
  const count = new DataView(buffer).getUint32(HEAD, true);
  return {
    node: new Uint32Array(buffer, 8, count),
    displacement: new Int16Array(buffer, 8 + 4 * count, 3 * count),
  };
}

// 32 bytes, of which those before the first 0 count.
function word(buffer, at) {
  const bytes = new Uint8Array(buffer, at, 32);
  return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
}

function field(buffer) {
  const head = new DataView(buffer);
  return {
    low: head.getFloat32(8, true), high: head.getFloat32(12, true),
    name: word(buffer, 16), unit: word(buffer, 48),
    value: new Int16Array(buffer, 80, head.getUint32(4, true)),
  };
}

function force(buffer) {
  const head = new DataView(buffer);
  const s = new Float32Array(buffer, HEAD, 27);
  const at = (first, count = 3) => Array.from(s.subarray(first, first + count));
  return {
    probe: head.getUint8(1), flags: s[0], position: at(1), orientation: at(4, 4), proxy: at(8),
    point: at(11), normal: at(14), force: at(17), torque: at(20), depth: s[23],
    indentation: s[24], stiffness: s[25], age: s[26],
    samples: new Float32Array(buffer, HEAD + 27 * 4, 4 * head.getUint16(2, true)),
  };
}

const DECODE = { 1: ['topology', topology], 2: ['delta', delta], 3: ['field', field], 4: ['force', force] };

export class Link extends EventTarget {
  constructor() {
    super();
    this.bytes = 0;
    this.isExpecting = false; // to hear of a server
    this.quiet = 0;           // ticks, not a time: a page that was busy has first to hear what waits
    this.open();
    setInterval(() => {
      this.quiet = this.isExpecting ? this.quiet + 1 : 0;
      if (this.quiet >= QUIET_TICKS) this.close();
    }, RETRY_MS);
  }

  open() {
    const address = new URL('/ws', location.href);
    address.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
    address.search = location.search; // the token, where one is needed
    this.socket = new WebSocket(address);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onmessage = (event) => this.take(event.data);
    this.socket.onopen = () => this.tell('open', {});
    this.socket.onclose = (event) => this.close(event.code === DISPLACED);
  }

  // A displaced page comes back when it is used: by itself it would displace the next.
  close(isDisplaced = false) {
    this.socket.onmessage = this.socket.onclose = null;
    this.socket.close();
    this.quiet = 0;
    this.tell('closed', { isDisplaced });
    if (!isDisplaced) {
      setTimeout(() => this.open(), RETRY_MS);
      return;
    }
    const used = new AbortController();
    for (const kind of ['pointerdown', 'keydown']) {
      addEventListener(kind, () => { used.abort(); this.open(); }, { signal: used.signal });
    }
  }

  tell(kind, detail) {
    this.dispatchEvent(new CustomEvent(kind, { detail }));
  }

  take(data) {
    this.quiet = 0;
    if (typeof data === 'string') {
      const message = JSON.parse(data);
      this.tell(message.type, message);
      return;
    }
    this.bytes += data.byteLength;
    const [kind, decode] = DECODE[new Uint8Array(data, 0, 1)[0]] ?? [];
    if (decode) this.tell(kind, decode(data));
  }

  on(kind, handle) {
    this.addEventListener(kind, (event) => handle(event.detail));
  }

  send(line) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(line);
  }

  command(name, argument = '') {
    this.send(`command ${name}${argument ? ` ${argument}` : ''}`);
  }
}
