// The client of serving plans: fetched with its view, not with the page.
import { lazily } from '@/api/client';
import { PlanService } from '@/api/gen/driftwise/v1/plan_service_pb';

export const plansApi = lazily(PlanService);
