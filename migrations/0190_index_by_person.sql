-- Everything held about a person is looked up by whoever did it, too: for the file of one's own data, and for erasing.
CREATE INDEX comments_by_author ON comments (school_id, author_id, made_at);
CREATE INDEX reviews_by_reviewer ON reviews (school_id, reviewed_by);
CREATE INDEX supervisions_by_supervisor ON supervisions (school_id, confirmed_by);
CREATE INDEX score_overrides_by_maker ON score_overrides (school_id, made_by, made_at);
CREATE INDEX survey_participations_by_person ON survey_participations (school_id, person_id);
