// The formula of a study: what was typed for a fit, else that of the address (?formula=), else that of the model that serves.
import { useState } from 'preact/hooks';
import { query } from '@/app/router';
import { useTyped } from '@/ui/use_typed';
import { firstFormula, isFormula } from './fit_formula';
import { useModels } from './use_models';

export function useStudyFormula(): [string, (text: string) => void] {
  const models = useModels();
  const [typed, setTyped] = useTyped('fit.formula');
  const [touched, setTouched] = useState(false);
  const serving = models.value?.models.find((model) => model.serving) ?? models.value?.models[0];
  const offered = query('formula') ?? (isFormula(typed) ? typed : (serving?.formula ?? firstFormula));
  return [touched ? typed : offered, (text) => { setTouched(true); setTyped(text); }];
}
