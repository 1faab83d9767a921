// The client of the study: fetched with its view, not with the page.
import { lazily } from '@/api/client';
import { StudyService } from '@/api/gen/driftwise/v1/study_service_pb';

export const studyApi = lazily(StudyService);
