// Where the picture is looked at from, and the projection: parallel, so that equal distances stay equal, the third axis
// up. Depth grows towards the onlooker.

export interface Camera {
  turn: number; // rad about the vertical
  lift: number; // rad above the horizontal: 0 from the side, pi/2 from above
  zoom: number; // 1: the box fills the picture
}

export const homeCamera: Camera = { turn: -0.62, lift: 0.42, zoom: 1 };

export function turned(camera: Camera, turn: number, lift: number): Camera {
  const full = 2 * Math.PI;
  return {
    ...camera,
    turn: (((camera.turn + turn) % full) + full) % full,
    lift: Math.min(Math.PI / 2, Math.max(-0.2, camera.lift + lift)),
  };
}

export function zoomed(camera: Camera, factor: number): Camera {
  return { ...camera, zoom: Math.min(20, Math.max(0.5, camera.zoom * factor)) };
}

export interface Projected {
  x: number; // px from the middle, to the right
  y: number; // px from the middle, down
  depth: number;
}

// unit: a point of the box, each coordinate -1 .. 1 times the box's share of the longest side.
export function projector(camera: Camera, pxPerUnit: number) {
  const [cosTurn, sinTurn] = [Math.cos(camera.turn), Math.sin(camera.turn)];
  const [cosLift, sinLift] = [Math.cos(camera.lift), Math.sin(camera.lift)];
  const scale = pxPerUnit * camera.zoom;
  return (x: number, y: number, z: number): Projected => {
    const right = x * cosTurn - y * sinTurn;
    const away = x * sinTurn + y * cosTurn;
    return {
      x: right * scale,
      y: (away * -sinLift - z * cosLift) * scale,
      depth: -away * cosLift + z * sinLift,
    };
  };
}
