(* ---- One state: x' = f(x) with y f(y) < 0 around 0 ---- *)

Lemma flow_continuous : forall x f t, continuity_pt x 0 -> (forall t, 0 < t -> derivable_pt_lim x t (f t)) ->
  0 <= t -> continuity_pt x t.
Proof.
  intros x f t C D [T|<-]; [|exact C]; apply derivable_continuous_pt; exists (f t); now apply D.
Qed.
Lemma never_above : forall (x : R -> R) f m h, m < h -> continuity_pt x 0 ->
  (forall t, 0 < t -> derivable_pt_lim x t (f (x t))) -> (forall y, m < y < h -> f y < 0) -> x 0 <= m ->
  forall t, 0 <= t -> x t <= m.
Proof.
  intros x f m h mh C D neg start t1 T1; apply Rnot_lt_le; intro up.
  set (E := fun s => 0 <= s <= t1 /\ x s <= m).
  destruct (completeness E) as [T [above least]].
  { exists t1; intros s [S _]; lra. }
  { exists 0; split; [lra|exact start]. }
  assert (T0 : 0 <= T) by (apply above; split; [lra|exact start]).
  assert (Tt : T <= t1) by (apply least; intros s [S _]; lra).
  assert (XC : continuity_pt x T) by (apply (flow_continuous x (fun t => f (x t))); auto).
  assert (XT : x T <= m).
  { apply (below_before x T m XC); intros d dpos; apply Classical_Prop.NNPP; intro none.
    assert (T <= T - d); [|lra]; apply least; intros s [S B].
    apply Rnot_lt_le; intro L; apply none; exists s; split; [split; [lra|apply above; split; [lra|exact B]]|exact B]. }
  destruct (below_nearby x T h XC ltac:(lra)) as [d [dpos near]].
  set (t2 := Rmin t1 (T + d / 2)).
  assert (lt : T < t1) by (destruct Tt as [L|e]; [exact L|rewrite e in XT; lra]).
  assert (t2lo : T < t2) by (unfold t2; apply Rmin_glb_lt; lra).
  assert (t2hi : t2 <= t1 /\ t2 <= T + d / 2) by (unfold t2; split; [apply Rmin_l|apply Rmin_r]).
  assert (out : forall s, T < s <= t1 -> m < x s).
  { intros s S; apply Rnot_le_lt; intro B; assert (s <= T); [apply above; split; [lra|exact B]|lra]. }
  assert (x t2 <= x T).
  { apply (falls_from x (fun s => f (x s)) T t2 t2lo XC); intros s S; [apply D; lra|].
    left; apply neg; split; [apply out; lra|apply near; lra]. }
  pose proof (out t2 ltac:(lra)); lra.
Qed.
Lemma to_zero : forall (x : R -> R) f m, (forall y, continuity_pt f y) -> f 0 = 0 ->
  (forall t, 0 < t -> derivable_pt_lim x t (f (x t))) -> (forall y, 0 < y <= m -> f y < 0) ->
  (forall t, 0 <= t -> 0 <= x t <= m) -> tends_to x 0.
Proof.
  intros x f m cont zero D neg inside eps epos.
  assert (down : forall s t, 0 < s -> s <= t -> x t <= x s).
  { apply (nonincreasing x (fun t => f (x t)) D); intros t Ht; destruct (inside t ltac:(lra)) as [[L|e] U].
    - left; apply neg; lra.
    - rewrite <- e, zero; lra. }
  assert (small : exists T, 0 < T /\ x T < eps).
  { apply Classical_Prop.NNPP; intro none.
    assert (big : forall t, 0 < t -> eps <= x t).
    { intros t T; apply Rnot_lt_le; intro L; apply none; exists t; split; assumption. }
    assert (em : eps <= m) by (pose proof (big 1 ltac:(lra)); destruct (inside 1 ltac:(lra)); lra).
    destruct (continuity_ab_maj f eps m em (fun y _ => cont y)) as [y [most Y]]; pose proof (neg y ltac:(lra)) as N.
    set (b := 1 + (m + 1) / - f y).
    assert (long : 0 < (m + 1) / - f y) by (apply Rdiv_lt_0_compat; lra).
    destruct (MVT_cor2 x (fun t => f (x t)) 1 b) as [c [E C]]; [unfold b; lra|intros; apply D; lra|].
    destruct (inside c ltac:(lra)); pose proof (most (x c) ltac:(pose proof (big c ltac:(lra)); lra)) as F.
    assert (G : f (x c) * (b - 1) <= f y * (b - 1)) by (apply Rmult_le_compat_r; unfold b; lra).
    replace (f y * (b - 1)) with (- (m + 1)) in G by (unfold b; field; lra).
    destruct (inside 1 ltac:(lra)), (inside b ltac:(unfold b; lra)); lra. }
  destruct small as [T [T0 S]]; exists T; intros t Ht; pose proof (down T t T0 ltac:(lra)).
  destruct (inside t ltac:(lra)); rewrite Rminus_0_r, Rabs_right; lra.
Qed.
Lemma mirrored_flow : forall (x : R -> R) f t, derivable_pt_lim x t (f (x t)) ->
  derivable_pt_lim (fun s => - x s) t (- f (- - x t)).
Proof. intros x f t D; rewrite Ropp_involutive; now apply (derivable_pt_lim_opp x). Qed.
Lemma from_above : forall (x : R -> R) f l h, (forall y, continuity_pt f y) -> f 0 = 0 -> continuity_pt x 0 ->
  (forall t, 0 < t -> derivable_pt_lim x t (f (x t))) -> (forall y, l < y < h -> y <> 0 -> y * f y < 0) ->
  l < 0 -> 0 <= x 0 < h -> (forall t, 0 <= t -> 0 <= x t <= x 0) /\ tends_to x 0.
Proof.
  intros x f l h cont zero C D sign l0 [x0 xh].
  assert (neg : forall y, 0 < y < h -> f y < 0) by (intros y Y; pose proof (sign y ltac:(lra) ltac:(lra)); nra).
  assert (inside : forall t, 0 <= t -> 0 <= x t <= x 0).
  { intros t T; split; [|apply (never_above x f (x 0) h); auto; [intros y Y; apply neg; lra|lra]].
    enough (- x t <= 0) by lra.
    apply (never_above (fun s => - x s) (fun y => - f (- y)) 0 (- l)); [lra| | | |lra|exact T].
    - apply (continuity_pt_opp x); exact C.
    - intros s S; apply mirrored_flow, D, S.
    - intros y Y; pose proof (sign (- y) ltac:(lra) ltac:(lra)); nra. }
  split; [exact inside|]; apply (to_zero x f (x 0)); auto; intros y Y; apply neg; lra.
Qed.
Theorem one_state : forall (x : R -> R) f l h, (forall y, continuity_pt f y) -> f 0 = 0 -> continuity_pt x 0 ->
  (forall t, 0 < t -> derivable_pt_lim x t (f (x t))) -> (forall y, l < y < h -> y <> 0 -> y * f y < 0) ->
  l < 0 < h -> l < x 0 < h -> (forall t, 0 <= t -> l < x t < h) /\ tends_to x 0.
Proof.
  intros x f l h cont zero C D sign [l0 h0] [xl xh]; destruct (Rle_or_lt 0 (x 0)) as [P|N].
  - destruct (from_above x f l h) as [A B]; auto; split; [|exact B]; intros t T; destruct (A t T); lra.
  - destruct (from_above (fun s => - x s) (fun y => - f (- y)) (- h) (- l)) as [A B].
    + intro y; apply (continuity_pt_opp (fun y => f (- y))), (continuity_pt_comp (fun y => - y) f); [|apply cont].
      apply (continuity_pt_opp (fun y => y)), (derivable_continuous_pt (fun y => y)), derivable_pt_id.
    + rewrite Ropp_0, zero; ring.
    + apply (continuity_pt_opp x); exact C.
    + intros s S; apply mirrored_flow, D, S.
    + intros y Y n; pose proof (sign (- y) ltac:(lra) ltac:(lra)); nra.
    + lra.
    + lra.
    + split; [intros t T; destruct (A t T); lra|].
      intros eps epos; destruct (B eps epos) as [T H]; exists T; intros t Ht; specialize (H t Ht).
      rewrite <- Rabs_Ropp; replace (- (x t - 0)) with (- x t - 0) by ring; exact H.
Qed.

(* What is one function up to a cut and another one beyond. *)
Lemma cut_continuous : forall f g c, (forall y, continuity_pt f y) -> (forall y, continuity_pt g y) -> f c = g c ->
  forall y, continuity_pt (fun s => if Rle_dec s c then f s else g s) y.
Proof.
  intros f g c F G same y eps epos.
  destruct (F y eps epos) as [d [dpos A]], (G y eps epos) as [e [e0 B]].
  set (r := if Req_EM_T y c then 1 else Rabs (y - c)).
  assert (rpos : 0 < r) by (unfold r; destruct (Req_EM_T y c); [lra|apply Rabs_pos_lt; lra]).
  exists (Rmin r (Rmin d e)); split; [repeat apply Rmin_pos; assumption|].
  intros s [S N]; simpl in *; unfold R_dist in *.
  assert (N1 : Rabs (s - y) < d) by (eapply Rlt_le_trans; [exact N|eapply Rle_trans; [apply Rmin_r|apply Rmin_l]]).
  assert (N2 : Rabs (s - y) < e) by (eapply Rlt_le_trans; [exact N|eapply Rle_trans; [apply Rmin_r|apply Rmin_r]]).
  assert (N3 : Rabs (s - y) < r) by (eapply Rlt_le_trans; [exact N|apply Rmin_l]).
  specialize (A s (conj S N1)); specialize (B s (conj S N2)); apply Rabs_def2 in N3.
  unfold r in N3; destruct (Req_EM_T y c) as [->|ne].
  - destruct (Rle_dec c c) as [_|k]; [|lra]; destruct (Rle_dec s c); [exact A|rewrite same; exact B].
  - destruct (Rle_dec s c), (Rle_dec y c); try assumption; exfalso.
    + rewrite (Rabs_right (y - c)) in N3 by lra; lra.
    + rewrite (Rabs_left (y - c)) in N3 by lra; lra.
Qed.
Lemma more_continuous : forall (g phi : R -> R) k c y, (forall y, continuity_pt g y) -> (forall y, continuity_pt phi y) ->
  continuity_pt (fun y => g y + k * phi (c * y)) y.
Proof.
  intros g phi k c y G P; apply (continuity_pt_plus g (fun y => k * phi (c * y))); [apply G|].
  apply (continuity_pt_scal (fun y => phi (c * y))), (continuity_pt_comp (fun y => c * y) phi); [|apply P].
  apply (continuity_pt_scal (fun y => y)), (derivable_continuous_pt (fun y => y)), derivable_pt_id.
Qed.
Lemma falls_right : forall y v, 0 <= y -> y <> 0 -> v < 0 -> y * v < 0.
Proof. intros; nra. Qed.
Lemma falls_left : forall y v, y <= 0 -> y <> 0 -> 0 < v -> y * v < 0.
Proof. intros; nra. Qed.
