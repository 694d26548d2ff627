// The socket: text is JSON; a binary message is the length of its header, the header, and numbers.

function unwrapped(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return { header, numbers: 4 + length, buffer };
}

// Places (3 n) and values (n) of a frame; null where nothing was solved there.
function fieldsOf({ header, numbers, buffer }) {
  const n = header.nodes ?? 0;
  if (!n) return null;
  return { places: new Float32Array(buffer, numbers, 3 * n), values: new Float32Array(buffer, numbers + 12 * n, n) };
}

class Wire {
  constructor(heard, lost) {
    this.heard = heard;
    this.lost = lost;
    this.wait = 500;
    this.open();
  }

  open() {
    const token = new URLSearchParams(location.search).get("token");
    const socket = (this.socket = new WebSocket(`ws://${location.host}/socket?token=${token}`));
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") {
        const { kind, ...told } = JSON.parse(data);
        this.heard(kind, told);
      } else {
        const message = unwrapped(data);
        this.heard(message.header.kind, message);
      }
    };
    socket.onopen = () => (this.wait = 500);
    socket.onclose = ({ code }) => {
      this.lost(code);
      // Another tab has taken over: this one does not take it back.
      if (code !== 4000) setTimeout(() => this.open(), (this.wait = Math.min(8000, 2 * this.wait)));
    };
  }

  say(what, told = {}) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({ do: what, ...told }));
  }
}
