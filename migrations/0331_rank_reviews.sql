-- What is looked at first: an attempt with a question that nobody has answered (4), one whose re-simulation differs (2), one that has failed
-- (1); the sum of what holds. Triggers keep it, so that no writer can forget it and the queue is read from an index.
ALTER TABLE sessions ADD COLUMN review_rank INTEGER NOT NULL DEFAULT 0 CHECK (review_rank BETWEEN 0 AND 7);

UPDATE sessions SET review_rank =
    4 * EXISTS (SELECT 1 FROM comments c WHERE c.school_id = sessions.school_id AND c.session_id = sessions.id
        AND c.kind = 'question' AND c.withdrawn_at IS NULL AND NOT EXISTS (
            SELECT 1 FROM comments a WHERE a.school_id = c.school_id AND a.session_id = c.session_id
                AND a.answers = c.id AND a.withdrawn_at IS NULL))
    + 2 * coalesce(verify_flagged, 0)
    + coalesce((SELECT 1 - g.passed FROM grades g WHERE g.school_id = sessions.school_id AND g.session_id = sessions.id), 0);

CREATE TRIGGER review_rank_follows_flags AFTER UPDATE OF verify_flagged ON sessions
WHEN NEW.verify_flagged IS NOT OLD.verify_flagged
BEGIN
    UPDATE sessions SET review_rank = (review_rank & 5) + 2 * coalesce(NEW.verify_flagged, 0)
    WHERE school_id = NEW.school_id AND id = NEW.id;
END;

CREATE TRIGGER review_rank_follows_flags_at_once AFTER INSERT ON sessions WHEN NEW.verify_flagged = 1
BEGIN
    UPDATE sessions SET review_rank = (review_rank & 5) + 2 WHERE school_id = NEW.school_id AND id = NEW.id;
END;

CREATE TRIGGER review_rank_follows_first_grades AFTER INSERT ON grades WHEN NEW.passed = 0
BEGIN
    UPDATE sessions SET review_rank = review_rank | 1 WHERE school_id = NEW.school_id AND id = NEW.session_id;
END;

CREATE TRIGGER review_rank_follows_grades AFTER UPDATE OF passed ON grades WHEN NEW.passed <> OLD.passed
BEGIN
    UPDATE sessions SET review_rank = (review_rank & 6) + 1 - NEW.passed
    WHERE school_id = NEW.school_id AND id = NEW.session_id;
END;

CREATE TRIGGER review_rank_follows_questions AFTER INSERT ON comments WHEN NEW.kind = 'question' AND NEW.withdrawn_at IS NULL
BEGIN
    UPDATE sessions SET review_rank = review_rank | 4 WHERE school_id = NEW.school_id AND id = NEW.session_id;
END;

CREATE TRIGGER review_rank_follows_answers AFTER INSERT ON comments WHEN NEW.answers IS NOT NULL
BEGIN
    UPDATE sessions SET review_rank = (review_rank & 3)
        + 4 * EXISTS (SELECT 1 FROM comments c WHERE c.school_id = NEW.school_id AND c.session_id = NEW.session_id
            AND c.kind = 'question' AND c.withdrawn_at IS NULL AND NOT EXISTS (
                SELECT 1 FROM comments a WHERE a.school_id = c.school_id AND a.session_id = c.session_id
                    AND a.answers = c.id AND a.withdrawn_at IS NULL))
    WHERE school_id = NEW.school_id AND id = NEW.session_id;
END;

CREATE TRIGGER review_rank_follows_withdrawals AFTER UPDATE OF withdrawn_at ON comments
BEGIN
    UPDATE sessions SET review_rank = (review_rank & 3)
        + 4 * EXISTS (SELECT 1 FROM comments c WHERE c.school_id = NEW.school_id AND c.session_id = NEW.session_id
            AND c.kind = 'question' AND c.withdrawn_at IS NULL AND NOT EXISTS (
                SELECT 1 FROM comments a WHERE a.school_id = c.school_id AND a.session_id = c.session_id
                    AND a.answers = c.id AND a.withdrawn_at IS NULL))
    WHERE school_id = NEW.school_id AND id = NEW.session_id;
END;

DROP INDEX sessions_to_review;
DROP INDEX sessions_to_review_by_trainee;
CREATE INDEX sessions_to_review ON sessions (school_id, review_rank, started_at, id)
WHERE state = 'scored' AND reviewed = 0;
CREATE INDEX sessions_to_review_by_trainee ON sessions (school_id, trainee_id, review_rank, started_at, id)
WHERE state = 'scored' AND reviewed = 0;
