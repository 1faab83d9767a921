import { modelApi } from '@/api/model';
import { useEvents } from '@/live/events';
import { useAsked } from '@/ui/use_asked';

// All models, newest first, with what was promoted when; asks again when one is made or begins to serve.
export function useModels() {
  const asked = useAsked('models', async (signal) => {
    const [{ models }, { promotions }] = await Promise.all([
      modelApi().listModels({}, { signal }),
      modelApi().listPromotions({}, { signal }),
    ]);
    return { models: models.reverse(), promotions: promotions.reverse() };
  });
  useEvents('model', () => asked.again());
  return asked;
}
