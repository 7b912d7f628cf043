-- A cohort's page asks for the extensions of its trainees, one by one.
CREATE INDEX assignment_extensions_by_person ON assignment_extensions (person_id, assignment_id);
CREATE INDEX segment_extensions_by_person ON segment_extensions (person_id, task_id);
-- A study's page lists its own participants, not those of every study of the school.
CREATE INDEX study_participants_by_study ON study_participants (school_id, study_id, group_place, added_at);
-- A survey's page lists its own letters.
CREATE INDEX survey_letters_by_survey ON survey_letters (school_id, survey_id, email);
-- A link that goes away looks for the letter that holds it.
CREATE INDEX survey_letters_by_response ON survey_letters (school_id, response_id);
