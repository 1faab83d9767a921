// What stands in the formula's field before anybody typed; it is no formula yet.
export const firstFormula = 'q ~ ';
export const isFormula = (text: string): boolean => text.trim() !== '' && text.trim() !== firstFormula.trim();
