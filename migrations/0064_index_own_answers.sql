-- What somebody has answered, for their export.
CREATE INDEX survey_responses_by_person ON survey_responses (school_id, person_id) WHERE person_id IS NOT NULL;
