-- What the database itself keeps, whoever writes: what never changes or goes, and what follows from what was added.

CREATE VIEW proofs AS
SELECT s.school_id, s.id AS session_id, s.trainee_id,
    coalesce(s.signed_by IS NOT NULL AND NOT s.verify_flagged, FALSE) AS signed,
    coalesce(NOT s.verify_flagged, FALSE) AS resimulated,
    EXISTS (SELECT 1 FROM supervisions v WHERE v.school_id = s.school_id AND v.session_id = s.id) AS supervised
FROM sessions s;

CREATE VIEW taught_trainees AS
SELECT teacher.school_id, teacher.person_id AS teacher_id, teacher.cohort_id, learner.person_id AS trainee_id
FROM cohort_members teacher
JOIN cohort_members learner ON learner.cohort_id = teacher.cohort_id AND learner.role = 'trainee'
WHERE teacher.role = 'instructor';

-- Refuses whatever it is asked about, in the words that it is given.
CREATE FUNCTION refuse() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN RAISE EXCEPTION '%', TG_ARGV[0]; END $$;

CREATE TRIGGER exercise_revisions_never_change BEFORE UPDATE ON exercise_revisions
FOR EACH ROW EXECUTE FUNCTION refuse('a published exercise revision never changes');
CREATE TRIGGER exercise_revisions_never_go BEFORE DELETE ON exercise_revisions
FOR EACH ROW EXECUTE FUNCTION refuse('a published exercise revision is never deleted');
CREATE TRIGGER exercise_revisions_never_go_all_at_once BEFORE TRUNCATE ON exercise_revisions
EXECUTE FUNCTION refuse('a published exercise revision is never deleted');
CREATE TRIGGER exercise_meshes_never_change BEFORE UPDATE ON exercise_meshes
FOR EACH ROW EXECUTE FUNCTION refuse('a published mesh never changes');
CREATE TRIGGER exercise_meshes_never_go BEFORE DELETE ON exercise_meshes
FOR EACH ROW EXECUTE FUNCTION refuse('a published mesh is never deleted');
CREATE TRIGGER exercise_meshes_never_go_all_at_once BEFORE TRUNCATE ON exercise_meshes
EXECUTE FUNCTION refuse('a published mesh is never deleted');
CREATE TRIGGER curriculum_revisions_never_change BEFORE UPDATE ON curriculum_revisions
FOR EACH ROW EXECUTE FUNCTION refuse('a published curriculum revision never changes');
CREATE TRIGGER curriculum_revisions_never_go BEFORE DELETE ON curriculum_revisions
FOR EACH ROW EXECUTE FUNCTION refuse('a published curriculum revision is never deleted');
CREATE TRIGGER curriculum_revisions_never_go_all_at_once BEFORE TRUNCATE ON curriculum_revisions
EXECUTE FUNCTION refuse('a published curriculum revision is never deleted');
CREATE TRIGGER scores_never_change BEFORE UPDATE ON scores
FOR EACH ROW EXECUTE FUNCTION refuse('a score never changes: a re-grading adds a row');
CREATE TRIGGER scores_never_go BEFORE DELETE ON scores
FOR EACH ROW EXECUTE FUNCTION refuse('a score is never deleted');
CREATE TRIGGER scores_never_go_all_at_once BEFORE TRUNCATE ON scores
EXECUTE FUNCTION refuse('a score is never deleted');
CREATE TRIGGER audit_log_never_changes BEFORE UPDATE ON audit_log
FOR EACH ROW EXECUTE FUNCTION refuse('the audit log is append-only');
CREATE TRIGGER audit_log_never_shrinks BEFORE DELETE ON audit_log
FOR EACH ROW EXECUTE FUNCTION refuse('the audit log is append-only');
CREATE TRIGGER audit_log_never_shrinks_all_at_once BEFORE TRUNCATE ON audit_log
EXECUTE FUNCTION refuse('the audit log is append-only');
CREATE TRIGGER score_overrides_never_go BEFORE DELETE ON score_overrides
FOR EACH ROW EXECUTE FUNCTION refuse('an override is never deleted');
CREATE TRIGGER score_overrides_never_go_all_at_once BEFORE TRUNCATE ON score_overrides
EXECUTE FUNCTION refuse('an override is never deleted');
CREATE TRIGGER instrument_revisions_never_change BEFORE UPDATE ON instrument_revisions
FOR EACH ROW EXECUTE FUNCTION refuse('a published instrument revision never changes');
CREATE TRIGGER instrument_revisions_never_go BEFORE DELETE ON instrument_revisions
FOR EACH ROW EXECUTE FUNCTION refuse('a published instrument revision is never deleted');
CREATE TRIGGER instrument_revisions_never_go_all_at_once BEFORE TRUNCATE ON instrument_revisions
EXECUTE FUNCTION refuse('a published instrument revision is never deleted');
CREATE TRIGGER ratings_never_go BEFORE DELETE ON ratings
FOR EACH ROW EXECUTE FUNCTION refuse('a rating is never deleted: the round is taken back');
CREATE TRIGGER ratings_never_go_all_at_once BEFORE TRUNCATE ON ratings
EXECUTE FUNCTION refuse('a rating is never deleted: the round is taken back');
CREATE TRIGGER regrade_reasons_never_go BEFORE DELETE ON regrade_reasons
FOR EACH ROW EXECUTE FUNCTION refuse('a reason is never deleted');
CREATE TRIGGER regrade_reasons_never_go_all_at_once BEFORE TRUNCATE ON regrade_reasons
EXECUTE FUNCTION refuse('a reason is never deleted');
CREATE TRIGGER exercise_pictures_never_change BEFORE UPDATE ON exercise_pictures
FOR EACH ROW EXECUTE FUNCTION refuse('a published picture never changes');
CREATE TRIGGER exercise_pictures_never_go BEFORE DELETE ON exercise_pictures
FOR EACH ROW EXECUTE FUNCTION refuse('a published picture is never deleted');
CREATE TRIGGER exercise_pictures_never_go_all_at_once BEFORE TRUNCATE ON exercise_pictures
EXECUTE FUNCTION refuse('a published picture is never deleted');

CREATE TRIGGER sent_marks_never_change BEFORE UPDATE ON segment_marks
FOR EACH ROW WHEN (OLD.sent_at IS NOT NULL) EXECUTE FUNCTION refuse('sent marks never change');
CREATE TRIGGER score_overrides_never_change BEFORE UPDATE ON score_overrides
FOR EACH ROW WHEN (NOT (NEW.reason = '[erased]' AND NEW.id = OLD.id AND NEW.school_id = OLD.school_id
    AND NEW.session_id = OLD.session_id AND NEW.score IS NOT DISTINCT FROM OLD.score
    AND NEW.passed IS NOT DISTINCT FROM OLD.passed AND NEW.made_by = OLD.made_by AND NEW.made_at = OLD.made_at))
EXECUTE FUNCTION refuse('an override never changes: another one is added');
CREATE TRIGGER regrade_reasons_never_change BEFORE UPDATE ON regrade_reasons
FOR EACH ROW WHEN (NOT (NEW.reason = '[erased]' AND NEW.score_id = OLD.score_id AND NEW.school_id = OLD.school_id
    AND NEW.session_id = OLD.session_id AND NEW.made_by IS NOT DISTINCT FROM OLD.made_by AND NEW.made_at = OLD.made_at))
EXECUTE FUNCTION refuse('a reason never changes: another grade has another');

CREATE FUNCTION refuse_gaps() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    IF NEW.seq <> (SELECT coalesce(max(seq), 0) + 1 FROM audit_log) THEN RAISE EXCEPTION '%', TG_ARGV[0]; END IF;
    RETURN NEW;
END $$;
CREATE TRIGGER audit_log_only_grows BEFORE INSERT ON audit_log
FOR EACH ROW EXECUTE FUNCTION refuse_gaps('the audit log is append-only');

-- Whether answers differ from older ones in nothing but texts that were erased.
CREATE FUNCTION are_answers_erased(older TEXT, newer TEXT) RETURNS BOOLEAN LANGUAGE SQL IMMUTABLE AS $$
    SELECT json_array_length(newer::JSON) = json_array_length(older::JSON) AND NOT EXISTS (
        SELECT 1 FROM jsonb_array_elements(newer::JSONB) WITH ORDINALITY AS n (value, place)
        JOIN jsonb_array_elements(older::JSONB) WITH ORDINALITY AS o (value, place) ON o.place = n.place
        WHERE n.value <> o.value AND NOT (jsonb_typeof(o.value) = 'string' AND n.value = '"[erased]"'))
$$;
CREATE TRIGGER finished_ratings_never_change BEFORE UPDATE ON ratings
FOR EACH ROW WHEN (OLD.finished_at IS NOT NULL AND NOT (NEW.id = OLD.id AND NEW.school_id = OLD.school_id
    AND NEW.round_id = OLD.round_id AND NEW.session_id = OLD.session_id AND NEW.rater_id = OLD.rater_id
    AND NEW.finished_at IS NOT DISTINCT FROM OLD.finished_at AND NEW.may_know = OLD.may_know
    AND are_answers_erased(OLD.answers, NEW.answers)))
EXECUTE FUNCTION refuse('a finished rating never changes');

-- The grade that counts is the newest computed score, or what was put in its place.
CREATE FUNCTION grade_by_score() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    INSERT INTO grades (school_id, session_id, score_id, score, passed)
    VALUES (NEW.school_id, NEW.session_id, NEW.id, NEW.score, NEW.passed)
    ON CONFLICT (school_id, session_id) DO UPDATE SET
        score_id = excluded.score_id,
        score = CASE WHEN grades.override_id IS NULL THEN excluded.score ELSE grades.score END,
        passed = CASE WHEN grades.override_id IS NULL THEN excluded.passed ELSE grades.passed END;
    RETURN NULL;
END $$;
CREATE TRIGGER grades_follow_scores AFTER INSERT ON scores
FOR EACH ROW EXECUTE FUNCTION grade_by_score();

CREATE FUNCTION grade_by_override() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    UPDATE grades SET
        override_id = CASE WHEN NEW.score IS NULL THEN NULL ELSE NEW.id END,
        score = coalesce(NEW.score, (SELECT c.score FROM scores c WHERE c.id = grades.score_id)),
        passed = coalesce(NEW.passed, (SELECT c.passed FROM scores c WHERE c.id = grades.score_id))
    WHERE school_id = NEW.school_id AND session_id = NEW.session_id;
    RETURN NULL;
END $$;
CREATE TRIGGER grades_follow_overrides AFTER INSERT ON score_overrides
FOR EACH ROW EXECUTE FUNCTION grade_by_override();

CREATE FUNCTION mark_reviewed() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    UPDATE sessions SET reviewed = TRUE WHERE school_id = NEW.school_id AND id = NEW.session_id;
    RETURN NULL;
END $$;
CREATE TRIGGER sessions_follow_reviews AFTER INSERT ON reviews
FOR EACH ROW EXECUTE FUNCTION mark_reviewed();

CREATE FUNCTION mark_unreviewed() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    UPDATE sessions SET reviewed = FALSE WHERE school_id = OLD.school_id AND id = OLD.session_id;
    RETURN NULL;
END $$;
CREATE TRIGGER sessions_follow_withdrawn_reviews AFTER DELETE ON reviews
FOR EACH ROW EXECUTE FUNCTION mark_unreviewed();

-- How soon an attempt is to be looked at: 4 for an open question, 2 where the re-simulation differs, 1 where it was not passed.
CREATE FUNCTION rank_by_flag() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    UPDATE sessions SET review_rank = (review_rank & 5) + 2 * coalesce(NEW.verify_flagged, FALSE)::INTEGER
    WHERE school_id = NEW.school_id AND id = NEW.id;
    RETURN NULL;
END $$;
CREATE TRIGGER review_rank_follows_flags AFTER UPDATE OF verify_flagged ON sessions
FOR EACH ROW WHEN (NEW.verify_flagged IS DISTINCT FROM OLD.verify_flagged) EXECUTE FUNCTION rank_by_flag();
CREATE TRIGGER review_rank_follows_flags_at_once AFTER INSERT ON sessions
FOR EACH ROW WHEN (NEW.verify_flagged) EXECUTE FUNCTION rank_by_flag();

CREATE FUNCTION rank_by_grade() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    UPDATE sessions SET review_rank = (review_rank & 6) + 1 - NEW.passed::INTEGER
    WHERE school_id = NEW.school_id AND id = NEW.session_id;
    RETURN NULL;
END $$;
CREATE TRIGGER review_rank_follows_first_grades AFTER INSERT ON grades
FOR EACH ROW WHEN (NOT NEW.passed) EXECUTE FUNCTION rank_by_grade();
CREATE TRIGGER review_rank_follows_grades AFTER UPDATE OF passed ON grades
FOR EACH ROW WHEN (NEW.passed <> OLD.passed) EXECUTE FUNCTION rank_by_grade();

CREATE FUNCTION rank_by_questions() RETURNS TRIGGER LANGUAGE plpgsql AS $$
BEGIN
    UPDATE sessions SET review_rank = (review_rank & 3)
        + 4 * EXISTS (SELECT 1 FROM comments c WHERE c.school_id = NEW.school_id AND c.session_id = NEW.session_id
            AND c.kind = 'question' AND c.withdrawn_at IS NULL AND NOT EXISTS (
                SELECT 1 FROM comments a WHERE a.school_id = c.school_id AND a.session_id = c.session_id
                    AND a.answers = c.id AND a.withdrawn_at IS NULL))::INTEGER
    WHERE school_id = NEW.school_id AND id = NEW.session_id;
    RETURN NULL;
END $$;
CREATE TRIGGER review_rank_follows_questions AFTER INSERT ON comments
FOR EACH ROW WHEN (NEW.kind = 'question' AND NEW.withdrawn_at IS NULL) EXECUTE FUNCTION rank_by_questions();
CREATE TRIGGER review_rank_follows_answers AFTER INSERT ON comments
FOR EACH ROW WHEN (NEW.answers IS NOT NULL) EXECUTE FUNCTION rank_by_questions();
CREATE TRIGGER review_rank_follows_withdrawals AFTER UPDATE OF withdrawn_at ON comments
FOR EACH ROW EXECUTE FUNCTION rank_by_questions();

-- Rows that are always there.
INSERT INTO heartbeat (id, beaten_at) VALUES (1, 0);
INSERT INTO service_time (id, observed_s) VALUES (1, 0);
