(* ---- Regions of attraction: V falls where V <= L, a set that lies between strips ---- *)

(* |row x| below a bound, x = now z *)
Definition strip := (list Z * Z)%type.
Definition inside (now : list (list Z)) (z : list R) (s : strip) : Prop := Rabs (dot (fst s) (at_ now z)) < IZR (snd s).
Definition touched (now : list (list Z)) (z : list R) (s : strip) : Prop := Rabs (dot (fst s) (at_ now z)) <= IZR (snd s).
Definition between_strips (n : nat) (now : list (list Z)) (F : list term) (L : Z) (ss : list strip) : bool :=
  (0 <=? L)%Z && forallb (fun s => let f := combine_forms (fst s) now in
    (0 <? snd s)%Z && nonneg n (times (snd s * snd s) F ++ [((- (L + 1))%Z, (f, f))])) ss.

Lemma in_strips : forall n now F L ss z, between_strips n now F L ss = true -> length z = n ->
  value F z < IZR L + 1 -> Forall (inside now z) ss.
Proof.
  intros n now F L ss z test len small; unfold between_strips in test; rewrite andb_true_iff, Z.leb_le in test.
  destruct test as [pos test]; apply IZR_le in pos; rewrite forallb_forall in test; apply Forall_forall; intros [row c] I.
  specialize (test _ I); cbv beta zeta in test; cbn [fst snd] in test; rewrite andb_true_iff, Z.ltb_lt in test.
  destruct test as [cpos test]; apply IZR_lt in cpos; apply (nonneg_sound n _ z) in test; [|exact len].
  rewrite value_app, value_times, mult_IZR in test; cbn [value] in test.
  rewrite opp_IZR, plus_IZR, dot_combine in test; unfold inside; cbn [fst snd].
  set (q := dot row (at_ now z)) in *; set (l := IZR L) in *; set (b := IZR c) in *; set (f := value F z) in *.
  rewrite <- (Rabs_right b) by lra; apply Rsqr_lt_abs_0; unfold Rsqr.
  apply (Rmult_lt_reg_l (l + 1)); [lra|]; assert (0 < b * b) by nra; nra.
Qed.

(* Discrete time; J >= 0 is what is left of an energy, if there is one. *)
Theorem attracted_by_steps : forall n P now next turn S N L ss (z : nat -> list R) (J : nat -> R),
  falls_by_steps n P now next (turn ++ S) N now = true -> between_strips n now (bilinear P now now) L ss = true ->
  (forall t, length (z t) = n) -> (forall t, at_ now (z (Datatypes.S t)) = at_ next (z t)) ->
  (forall t, 0 <= J t) -> (forall t, J (Datatypes.S t) = J t + value turn (z t)) ->
  (forall t, Forall (inside now (z t)) ss -> 0 <= value S (z t)) ->
  value (bilinear P now now) (z 0%nat) + J 0%nat <= IZR L ->
  (forall t, value (bilinear P now now) (z t) + J t <= IZR L) /\
  forall f, In f now -> Un_cv (fun t => dot f (z t)) 0.
Proof.
  intros n P now next turn S N L ss z J falls strips len step Jpos Jstep class start.
  assert (stays : forall t, value (bilinear P now now) (z t) + J t <= IZR L).
  { induction t as [|t IH]; [exact start|]; apply Rle_trans with (2 := IH); rewrite Jstep; pose proof (Jpos t).
    pose proof (class t (in_strips n now _ L ss (z t) strips (len t) ltac:(lra))) as C.
    unfold falls_by_steps in falls; rewrite !andb_true_iff, Z.ltb_lt in falls; destruct falls as [[pos _] falls].
    apply IZR_lt in pos; pose proof (nonneg_sound n _ (z t) falls (len t)) as F.
    rewrite !value_app, !value_times, !value_app, !value_times, !value_app in F; pose proof (squares_nonneg now (z t)).
    assert (E : value (bilinear P next next) (z t) = value (bilinear P now now) (z (Datatypes.S t))).
    { rewrite !value_bilinear, step; reflexivity. }
    rewrite E in F; apply (Rmult_le_reg_l (IZR N)); [exact pos|]; nra. }
  split; [exact stays|]; apply (by_steps_beside n P now next turn S N now z J falls len step Jpos Jstep).
  intro t; apply class, (in_strips n now _ L ss (z t) strips (len t)); pose proof (stays t); pose proof (Jpos t); lra.
Qed.

(* Continuous time: a function that falls as long as it is small stays small. *)
Lemma falls_from : forall v v' a b, a < b -> continuity_pt v a ->
  (forall t, a < t <= b -> derivable_pt_lim v t (v' t)) -> (forall t, a < t <= b -> v' t <= 0) -> v b <= v a.
Proof.
  intros v v' a b ab C D neg; apply Rnot_lt_le; intro up.
  destruct (C (v b - v a)) as [d [dpos near]]; [lra|].
  set (s := a + Rmin d (b - a) / 2).
  assert (M1 := Rmin_l d (b - a)); assert (M2 := Rmin_r d (b - a)).
  assert (M : 0 < Rmin d (b - a)) by (apply Rmin_glb_lt; lra).
  destruct (MVT_cor2 v v' s b) as [c [E S]]; [unfold s; lra|intros; apply D; unfold s in *; lra|].
  assert (N : Rabs (v s - v a) < v b - v a).
  { apply (near s); split; [split; [exact I|unfold s; lra]|]; simpl; unfold R_dist, s.
    rewrite Rabs_right; lra. }
  apply Rabs_def2 in N; pose proof (neg c ltac:(unfold s in *; lra)) as K.
  assert (0 < b - s) by (unfold s; lra); nra.
Qed.
Lemma stays : forall (near within : R -> Prop) (v v' : R -> R) (l : R),
  (forall t, 0 < t -> derivable_pt_lim v t (v' t)) -> continuity_pt v 0 -> (forall t, 0 < t -> near t -> v' t <= 0) ->
  (forall t, 0 <= t -> within t -> exists d, 0 < d /\ forall s, t < s < t + d -> near s) ->
  (forall t, 0 < t -> (forall d, 0 < d -> exists s, t - d < s <= t /\ 0 <= s /\ within s) -> within t) ->
  (forall t, near t -> v t <= l -> within t) -> (forall t, within t -> v t <= l) -> within 0 ->
  forall t, 0 <= t -> within t.
Proof.
  intros near within v v' l D C neg opens closes back low start t1 t1pos; apply Classical_Prop.NNPP; intro out.
  set (E := fun s => 0 <= s <= t1 /\ within s).
  assert (E0 : E 0) by (split; [lra|exact start]).
  destruct (completeness E) as [T [above least]]; [exists t1; intros s [S _]; lra|now exists 0|].
  assert (T0 : 0 <= T) by now apply above.
  assert (T1 : T <= t1) by (apply least; intros s [S _]; lra).
  assert (inT : within T).
  { destruct T0 as [T0| <-]; [|exact start]; apply closes; [exact T0|]; intros d dpos; apply Classical_Prop.NNPP; intro none.
    enough (T <= T - d) by lra; apply least; intros s [S W]; apply Rnot_lt_le; intro far; apply none.
    exists s; repeat split; try lra; [|exact W]; apply above; split; assumption. }
  assert (T < t1) by (destruct T1 as [T1| ->]; [exact T1|contradiction]).
  destruct (opens T T0 inT) as [d [dpos near_]].
  set (s := T + Rmin (d / 2) (t1 - T)).
  assert (M1 := Rmin_l (d / 2) (t1 - T)); assert (M2 := Rmin_r (d / 2) (t1 - T)).
  assert (M : 0 < Rmin (d / 2) (t1 - T)) by (apply Rmin_glb_lt; lra).
  assert (CT : continuity_pt v T).
  { destruct T0 as [T0| <-]; [|exact C]; apply derivable_continuous_pt; exists (v' T); now apply D. }
  assert (F : v s <= v T).
  { apply (falls_from v v'); [unfold s; lra|exact CT|intros; apply D; lra|].
    intros u U; apply neg; [lra|]; apply near_; unfold s in U; lra. }
  assert (W : within s).
  { apply back; [apply near_; unfold s; lra|]; apply Rle_trans with (1 := F); now apply low. }
  assert (s <= T) by (apply above; split; [unfold s; lra|exact W]); unfold s in *; lra.
Qed.

Lemma row_continuous : forall z now row t, (forall f, In f now -> continuity_pt (fun t => dot f (z t)) t) ->
  continuity_pt (fun t => dot row (at_ now (z t))) t.
Proof.
  intros z; induction now as [|f now IH]; intros [|a row] t C; simpl; try (apply continuity_pt_const; intros ? ?; reflexivity).
  apply (continuity_pt_plus (fun t => IZR a * dot f (z t)) (fun t => dot row (at_ now (z t)))).
  - apply (continuity_pt_scal (fun t => dot f (z t))), C; now left.
  - apply IH; intros g G; apply C; now right.
Qed.
Lemma form_continuous : forall z now xs P t, (forall f, In f now -> continuity_pt (fun t => dot f (z t)) t) ->
  (forall f, In f xs -> continuity_pt (fun t => dot f (z t)) t) ->
  continuity_pt (fun t => value (bilinear P xs now) (z t)) t.
Proof.
  intros z now; induction xs as [|x xs IH]; intros [|row P] t C D; simpl; try (apply continuity_pt_const; intros ? ?; reflexivity).
  apply (continuity_pt_plus (fun t => 1 * (dot x (z t) * dot (combine_forms row now) (z t)))
    (fun t => value (bilinear P xs now) (z t))).
  - apply (continuity_pt_scal (fun t => dot x (z t) * dot (combine_forms row now) (z t))).
    apply (continuity_pt_mult (fun t => dot x (z t)) (fun t => dot (combine_forms row now) (z t))); [apply D; now left|].
    intros eps epos; destruct (row_continuous z now row t C eps epos) as [d [dpos H]].
    exists d; split; [exact dpos|]; intros s S; rewrite !dot_combine; now apply H.
  - apply IH; [exact C|]; intros g G; apply D; now right.
Qed.
Lemma flows_continuous : forall z now next, flows z now next ->
  (forall f, In f now -> continuity_pt (fun t => dot f (z t)) 0) ->
  forall t, 0 <= t -> forall f, In f now -> continuity_pt (fun t => dot f (z t)) t.
Proof.
  intros z now next F C t [T| <-]; [|exact C]; clear C; induction F as [|f g fs gs D F IH]; intros h H; [easy|].
  destruct H as [<-|H]; [|now apply IH]; apply derivable_continuous_pt; exists (dot g (z t)); now apply D.
Qed.
Lemma below_nearby : forall f t c, continuity_pt f t -> f t < c -> exists d, 0 < d /\ forall s, t < s < t + d -> f s < c.
Proof.
  intros f t c C L; destruct (C (c - f t)) as [d [dpos near]]; [lra|]; exists d; split; [exact dpos|]; intros s S.
  assert (N : Rabs (f s - f t) < c - f t).
  { apply (near s); split; [split; [exact I|lra]|]; simpl; unfold R_dist; rewrite Rabs_right; lra. }
  apply Rabs_def2 in N; lra.
Qed.
Lemma below_before : forall f t c, continuity_pt f t -> (forall d, 0 < d -> exists s, t - d < s <= t /\ f s <= c) -> f t <= c.
Proof.
  intros f t c C H; apply Rnot_lt_le; intro L; destruct (C (f t - c)) as [d [dpos near]]; [lra|].
  destruct (H d dpos) as [s [S B]]; destruct (Req_dec s t) as [->|N]; [lra|].
  assert (M : Rabs (f s - f t) < f t - c).
  { apply (near s); split; [split; [exact I|lra]|]; simpl; unfold R_dist; rewrite Rabs_left1; lra. }
  apply Rabs_def2 in M; lra.
Qed.
Lemma inside_nearby : forall z now ss t, (forall f, In f now -> continuity_pt (fun t => dot f (z t)) t) ->
  Forall (inside now (z t)) ss -> exists d, 0 < d /\ forall s, t < s < t + d -> Forall (inside now (z s)) ss.
Proof.
  intros z now ss t C H; induction H as [|[row c] ss H F IH]; [exists 1; split; [lra|]; intros; constructor|].
  destruct IH as [d [dpos D]].
  destruct (below_nearby (fun t => Rabs (dot row (at_ now (z t)))) t (IZR c)) as [e [epos E]].
  - apply (continuity_pt_comp (fun t => dot row (at_ now (z t))) Rabs); [now apply row_continuous|apply Rcontinuity_abs].
  - exact H.
  - exists (Rmin d e); assert (M1 := Rmin_l d e); assert (M2 := Rmin_r d e).
    split; [now apply Rmin_glb_lt|]; intros s S; constructor; [apply E|apply D]; lra.
Qed.

(* V = x^T P x + J: J is at least a quadratic form [low] where the strips [own] are kept to, and they bound its set. *)
Theorem attracted_in_time : forall n P now next rows low turn S N L own more (z : R -> list R) (J : R -> R),
  falls_in_time n P now next rows low turn S N = true ->
  between_strips n now (bilinear P now now ++ low) L (own ++ more) = true ->
  (forall t, length (z t) = n) -> flows z now next ->
  (forall f, In f now -> continuity_pt (fun t => dot f (z t)) 0) -> continuity_pt J 0 ->
  (forall t, 0 <= t -> Forall (touched now (z t)) own -> value low (z t) <= J t) ->
  (forall t, 0 < t -> derivable_pt_lim J t (value turn (z t))) ->
  (forall t, 0 < t -> Forall (inside now (z t)) (own ++ more) -> 0 <= value S (z t)) ->
  value (bilinear P now now) (z 0) + J 0 <= IZR L -> Forall (touched now (z 0)) own ->
  (forall t, 0 <= t -> value (bilinear P now now) (z t) + J t <= IZR L /\ Forall (touched now (z t)) own) /\
  forall row, In row rows -> tends_to (fun t => dot row (at_ now (z t))) 0.
Proof.
  intros n P now next rows low turn S N L own more z J falls strips len F C CJ above DJ class start kept.
  set (v := fun t => value (bilinear P now now) (z t) + J t).
  set (v' := fun t => value (bilinear P now next) (z t) + value (bilinear P next now) (z t) + value turn (z t)).
  assert (Call := flows_continuous z now next F C).
  assert (D : forall t, 0 < t -> derivable_pt_lim v t (v' t)).
  { intros t T; apply (derivable_pt_lim_plus (fun t => value (bilinear P now now) (z t)) J); [now apply flow_bilinear|auto]. }
  assert (Cv : forall t, 0 <= t -> continuity_pt v t).
  { intros t [T| <-]; [apply derivable_continuous_pt; exists (v' t); now apply D|].
    apply (continuity_pt_plus (fun t => value (bilinear P now now) (z t)) J); [|exact CJ]; now apply form_continuous. }
  assert (all : forall t, 0 <= t -> Forall (touched now (z t)) own -> v t < IZR L + 1 ->
    Forall (inside now (z t)) (own ++ more)).
  { intros t T W U; apply (in_strips n now _ L (own ++ more) (z t) strips (len t)); rewrite value_app.
    pose proof (above t T W); unfold v in U; lra. }
  assert (soft : forall t, Forall (inside now (z t)) own -> Forall (touched now (z t)) own).
  { intros t; apply Forall_impl; intros s; unfold inside, touched; lra. }
  set (near := fun t => v t < IZR L + 1 /\ Forall (inside now (z t)) own).
  set (within := fun t => v t <= IZR L /\ Forall (touched now (z t)) own).
  assert (W : forall t, 0 <= t -> within t).
  { apply (stays near within v v' (IZR L)); [exact D|apply Cv; lra| | | |intros t [_ O] B; split; auto|intros t [B _]; exact B|split; assumption].
    - intros t T [U O]; pose proof (class t T (all t ltac:(lra) (soft t O) U)) as K.
      unfold falls_in_time in falls; rewrite !andb_true_iff, Z.ltb_lt in falls; destruct falls as [[pos _] falls].
      apply IZR_lt in pos; pose proof (nonneg_sound n _ (z t) falls (len t)) as M.
      rewrite !value_app, !value_times, !value_app, !value_times, !value_app in M.
      pose proof (squares_nonneg (mixed rows now) (z t)); pose proof (squares_nonneg (mixed rows next) (z t)).
      unfold v'; apply (Rmult_le_reg_l (IZR N)); [exact pos|]; nra.
    - intros t T [B O]; pose proof (all t T O ltac:(lra)) as A; apply Forall_app in A as [A _].
      destruct (inside_nearby z now own t (Call t T) A) as [d [dpos H]].
      destruct (below_nearby v t (IZR L + 1) (Cv t T) ltac:(lra)) as [e [epos E]].
      exists (Rmin d e); assert (M1 := Rmin_l d e); assert (M2 := Rmin_r d e).
      split; [now apply Rmin_glb_lt|]; intros s Hs; split; [apply E|apply H]; lra.
    - intros t T H; split.
      + apply below_before; [apply Cv; lra|]; intros d dpos; destruct (H d dpos) as [s [B [_ [K _]]]]; now exists s.
      + apply Forall_forall; intros [row c] I; unfold touched; cbn [fst snd].
        apply (below_before (fun t => Rabs (dot row (at_ now (z t))))).
        * apply (continuity_pt_comp (fun t => dot row (at_ now (z t))) Rabs); [|apply Rcontinuity_abs].
          apply row_continuous; intros f If; apply Call; [lra|exact If].
        * intros d dpos; destruct (H d dpos) as [s [B [_ [_ K]]]]; exists s; split; [exact B|].
          rewrite Forall_forall in K; exact (K (row, c) I). }
  split; [exact W|]; apply (in_time n P now next rows low turn S N z J falls len F); [|exact DJ|].
  - intros t T; apply above; [lra|apply W; lra].
  - intros t T; destruct (W t ltac:(lra)) as [B O]; apply class; [exact T|]; apply all; [lra|exact O|lra].
Qed.

(* ---- What holds of a nonlinearity on an interval ---- *)

Definition in_sector_up_to (c l u : R) (phi : R -> R) : Prop :=
  phi 0 = 0 /\ forall y, Rabs y <= c -> l * (y * y) <= y * phi y <= u * (y * y).
Lemma abs_within : forall y c, Rabs y <= c -> - c <= y <= c.
Proof. intros y c; unfold Rabs; destruct (Rcase_abs y); lra. Qed.
Lemma wider : forall c l u c' l' u' phi, in_sector_up_to c l u phi -> c' <= c -> l' <= l -> u <= u' ->
  in_sector_up_to c' l' u' phi.
Proof.
  intros c l u c' l' u' phi [Z H] C L U; split; [exact Z|]; intros y Y; destruct (H y ltac:(lra)) as [A B].
  pose proof (Rle_0_sqr y) as Q; unfold Rsqr in Q; split; nra.
Qed.
Lemma local_term : forall c l u phi y w, in_sector_up_to c l u phi -> phi y = w -> Rabs y <= c ->
  0 <= (u * y - w) * (w - l * y).
Proof.
  intros c l u phi y w [Z H] <- Y; destruct (H y Y) as [A B]; destruct (Req_dec y 0) as [->|N]; [rewrite Z; lra|].
  assert (0 < y * y) by nra; apply (Rmult_le_reg_l (y * y)); [assumption|].
  replace (y * y * ((u * y - phi y) * (phi y - l * y))) with ((u * (y * y) - y * phi y) * (y * phi y - l * (y * y))) by ring.
  rewrite Rmult_0_r; apply Rmult_le_pos; lra.
Qed.
Lemma local_size : forall c l u m phi y w, in_sector_up_to c l u phi -> phi y = w -> Rabs y <= c -> 0 <= m ->
  - m <= l -> u <= m -> - (m * c) <= w <= m * c.
Proof.
  intros c l u m phi y w [Z H] <- Y M L U; destruct (H y Y) as [A B]; apply abs_within in Y.
  assert (Q : 0 <= y * y) by nra.
  assert (A' : - (m * (y * y)) <= y * phi y) by nra; assert (B' : y * phi y <= m * (y * y)) by nra; clear A B.
  destruct (Rtotal_order y 0) as [N|[->|N]]; [|rewrite Z; nra|].
  - assert (m * y <= phi y <= - (m * y)) by (split; apply (Rmult_le_reg_l (- y)); lra); nra.
  - assert (- (m * y) <= phi y <= m * y) by (split; apply (Rmult_le_reg_l y); lra); nra.
Qed.
Lemma same_sign : forall a b, a <= 0 -> b <= 0 -> 0 <= a * b.
Proof. intros; nra. Qed.
Lemma continuous_same : forall f g k t, (forall s, f s = k * g s) -> continuity_pt g t -> continuity_pt f t.
Proof.
  intros f g k t E C; intros eps epos; destruct (continuity_pt_scal g k t C eps epos) as [d [dpos H]].
  exists d; split; [exact dpos|]; intros s S; rewrite !E; now apply (H s).
Qed.
Lemma integral_continuous : forall Phi phi sigma t, integral_of Phi phi -> continuity_pt sigma t ->
  continuity_pt (fun t => Phi (sigma t)) t.
Proof.
  intros Phi phi sigma t [_ D] C; apply (continuity_pt_comp sigma Phi); [exact C|].
  apply derivable_continuous_pt; exists (phi (sigma t)); apply D.
Qed.
