import type { Shape } from './shapes';

export function paintShapes(context: CanvasRenderingContext2D, shapes: readonly Shape[], font: string): void {
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  for (const shape of shapes) paintShape(context, shape, font);
}

function paintShape(context: CanvasRenderingContext2D, shape: Shape, font: string): void {
  if (shape.kind === 'text') {
    context.font = `${shape.strong ? '600 ' : ''}13px ${font}`;
    context.fillStyle = shape.colour;
    context.fillText(shape.text, shape.x, shape.y);
    return;
  }
  context.beginPath();
  if (shape.kind === 'line') {
    context.setLineDash(shape.dash ? [4, 4] : []);
    context.moveTo(shape.x1, shape.y1);
    context.lineTo(shape.x2, shape.y2);
    context.strokeStyle = shape.colour;
    context.lineWidth = shape.width;
    context.stroke();
    return;
  }
  const { x, y, size } = shape;
  context.lineWidth = 1.5;
  if (shape.kind === 'dot') {
    context.arc(x, y, size, 0, 2 * Math.PI);
    context.fillStyle = shape.colour;
    context.fill();
    return;
  }
  if (shape.kind === 'ring') context.arc(x, y, size, 0, 2 * Math.PI);
  else if (shape.kind === 'diamond') {
    context.moveTo(x, y - size);
    context.lineTo(x + size, y);
    context.lineTo(x, y + size);
    context.lineTo(x - size, y);
    context.closePath();
  } else {
    context.moveTo(x - size, y);
    context.lineTo(x + size, y);
    context.moveTo(x, y - size);
    context.lineTo(x, y + size);
  }
  context.strokeStyle = shape.colour;
  context.stroke();
}
