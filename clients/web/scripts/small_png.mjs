// A screenshot with at most 256 colours: a third of its bytes, and nobody sees the difference on a page of flat colours.
// Reads what Chromium writes (8 bits, RGB or RGBA, not interlaced), writes an indexed PNG.
import { deflateSync, inflateSync } from 'node:zlib';

const signature = Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]);

function chunksOf(png) {
  const chunks = [];
  for (let at = 8; at < png.length; ) {
    const length = png.readUInt32BE(at);
    chunks.push({ type: png.toString('latin1', at + 4, at + 8), data: png.subarray(at + 8, at + 8 + length) });
    at += length + 12;
  }
  return chunks;
}

const paeth = (a, b, c) => {
  const p = a + b - c;
  const [pa, pb, pc] = [Math.abs(p - a), Math.abs(p - b), Math.abs(p - c)];
  return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
};

// Rows of RGB, alpha dropped: a screenshot is opaque.
function pixelsOf(png) {
  const chunks = chunksOf(png);
  const head = chunks[0].data;
  const [width, height] = [head.readUInt32BE(0), head.readUInt32BE(4)];
  const bytes = head[9] === 6 ? 4 : 3;
  if (head[8] !== 8 || (head[9] !== 2 && head[9] !== 6) || head[12] !== 0) throw new Error('not a PNG as Chromium writes it');
  const raw = inflateSync(Buffer.concat(chunks.filter((one) => one.type === 'IDAT').map((one) => one.data)));
  const stride = width * bytes;
  const lines = Buffer.alloc(stride * height);
  for (let y = 0; y < height; ++y) {
    const filter = raw[y * (stride + 1)];
    for (let i = 0; i < stride; ++i) {
      const at = y * stride + i;
      const left = i >= bytes ? lines[at - bytes] : 0;
      const up = y > 0 ? lines[at - stride] : 0;
      const corner = y > 0 && i >= bytes ? lines[at - stride - bytes] : 0;
      const guess = filter === 1 ? left : filter === 2 ? up : filter === 3 ? (left + up) >> 1 : filter === 4 ? paeth(left, up, corner) : 0;
      lines[at] = (raw[y * (stride + 1) + 1 + i] + guess) & 255;
    }
  }
  return { width, height, bytes, lines };
}

// At most 256 colours, the frequent ones first, but none close to one that is there already, as long as there is room: a
// mark of a few pixels keeps its own colour. Every other colour becomes the nearest of them.
function paletteOf({ bytes, lines }) {
  const counts = new Map();
  for (let at = 0; at < lines.length; at += bytes) {
    const colour = (lines[at] << 16) | (lines[at + 1] << 8) | lines[at + 2];
    counts.set(colour, (counts.get(colour) ?? 0) + 1);
  }
  const colours = [...counts].sort((a, b) => b[1] - a[1]).map(([colour]) => colour);
  const distance = (a, b) => {
    const [r, g, b2] = [(a >> 16) - (b >> 16), ((a >> 8) & 255) - ((b >> 8) & 255), (a & 255) - (b & 255)];
    return 2 * r * r + 4 * g * g + 3 * b2 * b2;
  };
  const palette = [];
  for (const apart of [6000, 2500, 1000, 400, 150, 0]) {
    for (const colour of colours) {
      if (palette.length < 256 && !palette.includes(colour) && palette.every((one) => distance(one, colour) > apart)) palette.push(colour);
    }
  }
  const index = new Map(palette.map((colour, i) => [colour, i]));
  for (const colour of colours) {
    if (index.has(colour)) continue;
    let best = 0;
    for (let i = 1; i < palette.length; ++i) if (distance(palette[i], colour) < distance(palette[best], colour)) best = i;
    index.set(colour, best);
  }
  return { palette, index };
}

const table = Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n >>> 0;
});
const crc = (buffer) => (buffer.reduce((sum, byte) => table[(sum ^ byte) & 255] ^ (sum >>> 8), 0xffffffff) ^ 0xffffffff) >>> 0;

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type, 'latin1'), data]);
  const out = Buffer.alloc(body.length + 8);
  out.writeUInt32BE(data.length, 0);
  body.copy(out, 4);
  out.writeUInt32BE(crc(body), body.length + 4);
  return out;
}

export function smallPng(png) {
  const picture = pixelsOf(png);
  const { palette, index } = paletteOf(picture);
  const { width, height, bytes, lines } = picture;
  const rows = Buffer.alloc((width + 1) * height);
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) {
      const at = (y * width + x) * bytes;
      rows[y * (width + 1) + 1 + x] = index.get((lines[at] << 16) | (lines[at + 1] << 8) | lines[at + 2]);
    }
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 3, 0, 0, 0], 8);
  const colours = Buffer.from(palette.flatMap((colour) => [colour >> 16, (colour >> 8) & 255, colour & 255]));
  return Buffer.concat([signature, chunk('IHDR', head), chunk('PLTE', colours), chunk('IDAT', deflateSync(rows, { level: 9 })), chunk('IEND', Buffer.alloc(0))]);
}
