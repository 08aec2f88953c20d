"""From parts to rows: how what tasks and limits ask for becomes the numbers of a hierarchy, tick after tick."""
