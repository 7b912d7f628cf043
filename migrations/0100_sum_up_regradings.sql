-- What a re-grading shows, summed up once its last attempt was looked at: its page reads this and a page of attempts.
ALTER TABLE regradings ADD COLUMN counts TEXT NOT NULL DEFAULT '[]'; -- JSON: attempts and sums of scores by outcome
ALTER TABLE regradings ADD COLUMN shown_sha256 TEXT; -- of the attempts and their grades as they stood; absent until shown

UPDATE regradings SET counts = (
    SELECT json_group_array(json_object('outcome', outcome, 'attempts', attempts, 'before', before, 'after', after))
    FROM (SELECT outcome, count(*) AS attempts, sum(before) AS before, sum(coalesce(after, before)) AS after
          FROM regrading_lines WHERE school_id = regradings.school_id AND regrading_id = regradings.id GROUP BY outcome))
WHERE state IN ('grading', 'done');

-- The worker finds nothing left to look at, and sums up.
UPDATE regradings SET state = 'looking' WHERE state = 'shown';
